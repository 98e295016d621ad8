"""``python -m grammarlab``: the command line where its script is not on the search path."""

from grammarlab.cli import main

if __name__ == "__main__":
    main()
