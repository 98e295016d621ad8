import { element } from "../shared/element.js";
import { textButton } from "../shared/menu.js";
import { makeSteps, shortly } from "../shared/scale.js";
import { zoneColour } from "./ground.js";

/** @typedef {import("./types.js").Parcel} Parcel */
/** @typedef {import("./types.js").State} State */

const STEPS = { preferences: { scale: "stars" } };

/**
 * What is known of the selected parcel, what can be done with it, and the zones.
 * @param {object} page
 * @param {(command: string, parameters?: object) => Promise<any>} page.ask
 * @param {(score: number | null, kind: string) => void} page.score
 * @param {(action: "reroll" | "pin" | "exclude") => void} page.change
 * @param {(id: string) => Promise<boolean>} page.find selects a parcel; false if there is none
 * @param {() => void} page.visit the selected parcel
 * @param {(step: number) => void} page.go to another parcel
 */
export function makePanel(page) {
  const name = element("h2", { class: "ct-name" });
  const facts = element("dl", { class: "ct-facts" });
  const rules = element("ul", { class: "ct-rules", "aria-label": "Rules" });
  const story = element("details", { open: true }, element("summary", {}, "Chosen by chance"), rules);
  const hint = element(
    "p",
    { class: "gl-hint" },
    "Click a building, or press N, for its parcel, zone, seed and rules.",
  );
  const reroll = textButton("Reroll", () => page.change("reroll"), { title: "Another building of this zone (R)" });
  const pin = textButton("Pin", () => page.change("pin"), { title: "Keep this building and its zone (P)" });
  const exclude = textButton("Exclude", () => page.change("exclude"), { title: "Nothing is built here (X)" });
  const visit = textButton("Go there", () => page.visit(), { title: "Go there (F)" });
  const steps = makeSteps(STEPS, "Score of this building", (score) => page.score(score, "stars"));
  const exact = element("input", {
    class: "gl-input ct-exact",
    type: "number",
    min: "0",
    max: "100",
    step: "1",
    placeholder: "0–100",
    "aria-label": "Score of this building, 0 to 100",
    onchange: () => {
      if (exact.value === "") page.score(null, "score");
      else if (exact.checkValidity()) page.score(exact.valueAsNumber, "score");
      else exact.reportValidity();
    },
  });
  const said = element("span", { class: "gl-count", role: "status" });
  const scoring = element(
    "div",
    { class: "gl-plain", role: "group", "aria-label": "Score" },
    element("div", { class: "gl-row" }, element("h3", {}, "Score"), element("span", { class: "gl-space" }), said),
    element("div", { class: "gl-row" }, steps.element, exact),
  );
  const actions = element("div", { class: "gl-row gl-wrap" }, visit, reroll, pin, exclude);
  const chosen = element(
    "section",
    { class: "gl-card", "aria-label": "Selected parcel" },
    element(
      "div",
      { class: "gl-row" },
      name,
      element("span", { class: "gl-space" }),
      textButton("‹", () => page.go(-1), { "aria-label": "Previous building", title: "Previous building (B)" }),
      textButton("›", () => page.go(1), { "aria-label": "Next building", title: "Next building (N)" }),
    ),
    actions,
    hint,
    scoring,
    facts,
    story,
  );
  const query = element("input", {
    class: "gl-input",
    type: "search",
    placeholder: "Find a parcel by its id",
    "aria-label": "Find a parcel by its id",
  });
  const search = element(
    "form",
    {
      class: "gl-row",
      onsubmit: async (/** @type {Event} */ event) => {
        event.preventDefault();
        const found = await page.find(query.value.trim());
        query.setCustomValidity(found ? "" : "There is no parcel with this id.");
        query.reportValidity();
      },
    },
    query,
    element("button", { class: "gl-button" }, "Find"),
  );
  query.addEventListener("input", () => query.setCustomValidity(""));
  const counts = element("p", { class: "gl-hint" });
  const zones = element("ul", { class: "ct-zones" });
  const summary = element(
    "section",
    { class: "gl-card", "aria-label": "Zones" },
    element("h2", {}, "Zones"),
    zones,
    counts,
  );

  /** @param {Parcel | null} parcel */
  function show(parcel) {
    name.textContent = parcel ? parcel.id : "No building selected";
    hint.hidden = Boolean(parcel);
    facts.replaceChildren(
      ...(parcel?.facts ?? []).flatMap(([fact, value]) => [element("dt", {}, fact), element("dd", {}, value)]),
    );
    const isBuilt = parcel?.status === "built";
    visit.disabled = !parcel;
    exclude.textContent = parcel?.pin === "excluded" ? "Include" : "Exclude";
    pin.textContent = parcel?.pin === "pinned" ? "Unpin" : "Pin";
    scoring.hidden = !isBuilt || !parcel.scorable;
    const { score = null, kind = null } = parcel?.said ?? {};
    steps.draw({ score, kind });
    if (document.activeElement !== exact) exact.value = score === null ? "" : String(score);
    said.textContent = score === null ? "" : `scored ${shortly({ score, kind: "score" })}`;
  }

  /** @param {State} state @param {Parcel | null} parcel */
  function update(state, parcel) {
    const isBuilt = parcel?.status === "built";
    reroll.disabled = pin.disabled = !state.editable || !isBuilt;
    exclude.disabled = !state.editable || !parcel || (!isBuilt && parcel.pin !== "excluded");
    zones.replaceChildren(...state.zones.map((zone, number) => zoneRow(zone, number, state)));
    const empty = Object.entries(state.empty).map(([reason, number]) => `${number} ${reason || "empty"}`);
    counts.textContent = [`${state.built.toLocaleString()} buildings`, ...empty].join(", ");
  }

  /** @param {import("./types.js").Zone} zone @param {number} number @param {State} state */
  function zoneRow({ name: zone, grammar, parcels, scored, learnable, learned }, number, state) {
    const learn = textButton("Learn", () => void page.ask("learn", { zone }), {
      title: `Learn which buildings of ${zone} are liked from ${scored} scores, and build them`,
      "aria-label": `Learn ${zone}`,
      disabled: !state.editable || !learnable || Boolean(state.busy),
    });
    const swatch = element("i", { class: "ct-swatch" });
    swatch.style.setProperty("background", zoneColour(number));
    return element(
      "li",
      {},
      swatch,
      element(
        "span",
        { class: "ct-zone" },
        element("b", {}, zone),
        element(
          "small",
          {},
          [grammar, `${parcels.toLocaleString()} built`, `${scored} scored`].filter(Boolean).join(" · "),
        ),
        learned ? element("small", {}, learned) : null,
      ),
      learn,
    );
  }

  const side = element("aside", { class: "gl-side ct-side" }, chosen, summary, search);
  /** @param {string[]} lines about how the building was derived */
  function tell(lines) {
    rules.replaceChildren(...lines.map((line) => element("li", {}, line)));
    story.hidden = !lines.length;
  }

  show(null);
  tell([]);
  return { element: side, show, tell, update };
}
