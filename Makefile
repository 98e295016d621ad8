# demo   sample 16 buildings, as GLB files and one picture; then learn from 128 scores to sample those of one style
# test   everything that must hold: format, lint, types, layers, tests; a fifth of the bulk of cases, another each week
# test-all  the same with all cases: once a week, and before a release
# mutants   how many of 60 mistakes put into the code are noticed by its tests: takes an hour
# check  the fast, static half of it
# types  the slow one: pyright over all files
# docs   the documentation, as pages in out/site; tests build it too
# reference  the generated parts of the documentation, in docs/
# bench  how fast it is, as ratios within one run
# pictures  the pictures of the guide, and samples while a grammar is learned, in motion
# plausible-trees   how many trees each clause of T1 removes
# species-pictures  the pictures of bark and leaves of the shipped species
# cga-pictures  the pictures of the operations of CGA
# tree-parameters  the pictures of every parameter of trees, and of the species
# quarter  a quarter of a city with three zones learned from simulated persons, in out/quarter
# quarter-pictures  the same, and its pictures for the documentation
# park      a park whose trees are learned from a sketch, and its picture
# screens   the pictures of the pages in a browser
# facades  make the shipped facades and the family of one again, from their rules, and the pictures of their edits

PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV   := .venv
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --quiet --disable-pip-version-check
CODE   := grammarlab tests benchmarks notebooks docs/gen
export PIP_CONSTRAINT := $(CURDIR)/constraints.txt

.DEFAULT_GOAL := test
.DELETE_ON_ERROR:
# Material for MkDocs tells at every start that it has a successor.
export NO_MKDOCS_2_WARNING := 1

.PHONY: demo test pytest test-all mutants check types docs reference pictures screens bench facades scan-pictures species-pictures cga-pictures tree-parameters plausible-trees quarter quarter-pictures park format clean chromium

demo: $(VENV)/.learn
	$(BIN)/grammarlab sample building -n 16 --seed 5 -o out/demo
	$(BIN)/grammarlab label B1 -n 128 --seed 1 -o out/demo-learned/labels.csv
	$(BIN)/grammarlab learn building --labels out/demo-learned/labels.csv -o out/demo-learned/building.cga \
		--report out/demo-learned
	$(BIN)/grammarlab sample out/demo-learned/building.cga -n 16 --seed 5 -o out/demo-learned/samples

# Types are checked while tests wait for processes and pages.
test: $(VENV)/.dev chromium
	@$(MAKE) --no-print-directory -j 2 pytest check types

pytest: $(VENV)/.dev
	$(BIN)/pytest -q -n 2 --dist worksteal

test-all: export GRAMMARLAB_CASES := all
test-all: test

mutants: $(VENV)/.dev
	$(BIN)/python -m benchmarks.mutants

check: $(VENV)/.dev
	$(BIN)/ruff format --check $(CODE)
	$(BIN)/ruff check $(CODE)
	$(BIN)/ty check --python $(VENV)
	$(BIN)/lint-imports

# It takes 15 times as long as ty, and notices some mistakes that ty does not.
types: $(VENV)/.dev
	$(BIN)/pyright --pythonpath $(BIN)/python

docs: $(VENV)/.dev
	$(BIN)/python -m mkdocs --quiet build

reference: $(VENV)/.dev
	$(BIN)/python -m docs.gen.reference
	$(BIN)/python -m docs.gen.editors

# The page is tested in a real browser: Debian's Chromium, put there where that is allowed.
chromium:
	@command -v chromium-headless-shell >/dev/null || command -v chromium >/dev/null || { [ "$$(id -u)" = 0 ] && apt-get -qq update && { \
		apt-get -qq install -y --no-install-recommends chromium-headless-shell || \
		apt-get -qq install -y --no-install-recommends chromium; \
	}; } >/dev/null 2>&1 || echo "no Chromium, so tests in the browser are skipped: apt-get install chromium-headless-shell"

bench: $(VENV)/.dev
	$(BIN)/pytest -q benchmarks --override-ini python_files='bench_*.py'

SHEET := $(BIN)/python -c 'import sys; from PIL import Image; from grammarlab.runs.facade.gallery import sheet; \
	sheet([Image.open(each) for each in sys.argv[2:]]).save(sys.argv[1])'
SIX   := $(BIN)/grammarlab sample -n 6 --columns 6 --scale same --seed 1
GUIDE := out/guide
pictures: $(VENV)/.dev
	for page in grammar facade; do $(BIN)/python -m docs.gen.blocks docs/guide/$$page.md $(GUIDE)/$$page || exit 1; done
	$(SIX) $(GUIDE)/grammar/tower.cga -o $(GUIDE)/towers && cp $(GUIDE)/towers/tower.png docs/images/guide_towers.png
	$(SIX) $(GUIDE)/grammar/liked.cga -o $(GUIDE)/liked && cp $(GUIDE)/liked/liked.png docs/images/guide_liked.png
	$(SIX) $(GUIDE)/facade/family.cga -o $(GUIDE)/family && cp $(GUIDE)/family/family.png docs/images/guide_family.png
	$(SIX) $(GUIDE)/facade/liked.cga -o $(GUIDE)/middle && cp $(GUIDE)/middle/liked.png docs/images/guide_middle.png
	$(BIN)/grammarlab facade show $(GUIDE)/facade/house.facade.json --pixels 25 -o $(GUIDE)/house.png
	$(BIN)/grammarlab facade show $(GUIDE)/facade/wider/001.facade.json --pixels 25 -o $(GUIDE)/wider.png
	$(SHEET) docs/images/guide_house.png $(GUIDE)/house.png $(GUIDE)/wider.png
	$(BIN)/grammarlab label B1 -n 128 --seed 1 -o $(GUIDE)/labels.csv
	$(BIN)/python -m docs.gen.motion $(GUIDE)/labels.csv docs/images/learned.webp

FACADES := grammars/facades
FACE    := $(BIN)/grammarlab facade read $(FACADES)/houses.cga --face front --seed 1
facades: $(VENV)/.dev
	rm -f $(FACADES)/*.json $(FACADES)/*.png $(FACADES)/*.obj
	$(FACE) --start Townhouse --parts FrenchWindow,Shop,HouseDoor,Cornice,Band,Frieze,Plinth -o $(FACADES)/townhouse.json
	$(FACE) --start Arcade --parts ArchedWindow,SquareWindow,Portal,Cornice,Band,Plinth -o $(FACADES)/arcade.json
	$(FACE) --start School --parts Light,Pilaster,Belt,Cornice,Plinth -o $(FACADES)/school.json
	$(BIN)/python -m docs.gen.school_grids $(FACADES)/school.json
	$(FACE) --start Flats --parts WideWindow,Balcony,BalconyWindow,StairLight,EntranceDoor,Coping -o $(FACADES)/flats.json
	$(BIN)/grammarlab facade grammar $(FACADES)/arcade.json --widths 10:27 --heights 10:24 -o $(FACADES)/arcade_family.cga
	mv $(FACADES)/assets/*.obj $(FACADES)/ && rm -r $(FACADES)/assets  # the picture is there already
	for width in 14.7 21 31.5 42; do \
		$(BIN)/grammarlab facade edit $(FACADES)/arcade.json --width $$width -n 1 -o out/arcade/$$width && \
		$(BIN)/grammarlab facade show out/arcade/$$width/001.facade.json --pixels 20 -o out/arcade/$$width.png || exit 1; done
	for width in 6 9 12 18; do $(BIN)/grammarlab facade layers $(FACADES)/residential.toml --width $$width -n 1 \
		-o out/layers/residential$$width || exit 1; done
	for name in apartment concert_hall library; do \
		$(BIN)/grammarlab facade layers $(FACADES)/$$name.toml -n 1 -o out/layers/$$name || exit 1; done
	$(SHEET) docs/images/layers.png $(patsubst %,out/layers/%/001.png,\
		residential6 residential9 residential12 residential18 apartment concert_hall library)
	$(SHEET) docs/images/arcade_widths.png $(patsubst %,out/arcade/%.png,14.7 21 31.5 42)
	$(BIN)/python -m docs.gen.grid_figures docs/images

	for start in Block Shops Corner Curved; do \
		[ $$start = Curved ] && lot="--footprint $(FACADES)/curved_street.geojson" || lot=; \
		$(BIN)/grammarlab sample $(FACADES)/blocks.cga --start $$start $$lot -n 1 --format obj --no-image -o out/$$start && \
		$(BIN)/grammarlab facade synthesize out/$$start/blocks-00000.obj --rows 8 --columns 15 -o out/$$start/made && \
		cp out/$$start/made/001.png docs/images/synthesis_$$start.png || exit 1; done

screens: $(VENV)/.dev chromium
	$(BIN)/python -m docs.gen.screens

scan-pictures: $(VENV)/.dev
	$(BIN)/grammarlab facade scene --rows 4 --seed 3 -o out/scan/scene.json
	$(BIN)/grammarlab facade match out/scan/scene.json -o out/scan/found
	cp out/scan/found/match.png docs/images/scan_match.png

species-pictures: $(VENV)/.dev
	$(BIN)/python -m docs.gen.species_pictures grammars/species/assets

cga-pictures: $(VENV)/.dev
	$(BIN)/python -m docs.gen.cga_pictures

plausible-trees: $(VENV)/.dev
	$(BIN)/python -m docs.gen.tree_clauses docs/evaluation/plausible_trees.md

tree-parameters: $(VENV)/.dev
	$(BIN)/python -m docs.gen.species_sheet
	$(BIN)/python -m docs.gen.blocks docs/trees/index.md out/trees
	$(SIX) --seed 5 out/trees/sapling.toml -o out/trees/before && cp out/trees/before/sapling.png docs/images/saplings.png
	$(SIX) --seed 5 out/trees/liked.toml -o out/trees/after && cp out/trees/after/liked.png docs/images/saplings_liked.png
	$(BIN)/python -m docs.gen.tree_parameters

QUARTER := out/quarter
CITY    := $(BIN)/grammarlab city
STREET  := 400,319,84
quarter: $(VENV)/.learn  # three zones learned from simulated persons, and the city
	mkdir -p $(QUARTER)
	for zone in offices downtown houses; do \
		$(BIN)/grammarlab label scenarios/city/$$zone.toml -n 80 --seed 1 -o $(QUARTER)/$$zone.csv && \
		$(BIN)/grammarlab learn quarter --labels $(QUARTER)/$$zone.csv -o $(QUARTER)/$$zone.cga || exit 1; done
	$(CITY) learn grammars/city/quarter.plan.toml --answers grammars/city/answers.csv -o $(QUARTER)/quarter.zones.json
	$(CITY) build grammars/city/quarter.plan.toml -o $(QUARTER)/city

quarter-pictures: quarter
	$(CITY) draw grammars/city/quarter.plan.toml --size 1400x788 -o docs/images/quarter.jpg
	$(CITY) draw grammars/city/unlearned.plan.toml --size 1400x788 -o docs/images/quarter_unlearned.jpg
	$(CITY) draw grammars/city/quarter.plan.toml --size 1400x788 --at $(STREET) -o docs/images/quarter_street.jpg

park: $(VENV)/.learn  # trees learned from a sketch
	$(CITY) learn grammars/city/park.plan.toml --trees
	$(CITY) draw grammars/city/park.plan.toml --size 1400x788 -o docs/images/park.jpg

format: $(VENV)/.dev
	$(BIN)/ruff check --fix $(CODE)
	$(BIN)/ruff format $(CODE)

clean:
	rm -rf $(VENV) out build dist

$(VENV)/bin/python:
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "grammarlab needs Python 3.11 or newer: make PYTHON=/path/to/python3.11"; exit 1; }
	"$(PYTHON)" -m venv $(VENV)

# uv installs in a fifth of the time of pip, which does it where uv has no wheel or reaches no index.
# Without limits it tries to reach one for two minutes; with them pip starts after twenty seconds.
# Of all modules that are installed few are imported, and these are compiled then.
UV      := UV_HTTP_TIMEOUT=8 UV_HTTP_RETRIES=1 $(BIN)/uv
INSTALL = { $(PIP) install --no-compile --timeout 8 --retries 1 uv && $(UV) pip install --quiet --python $(BIN)/python --constraints constraints.txt -e $(1); } || \
	$(PIP) install --no-compile -e $(1)

$(VENV)/.learn: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(call INSTALL,'.[learn]')
	@touch $@

$(VENV)/.dev: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(call INSTALL,'.[dev]')
	@touch $@ $(VENV)/.learn
