"""Runs the code cells of a notebook, without Jupyter.

    run_notebook.py NOTEBOOK

Pictures are not shown: the notebook saves them in this folder.
"""

import json
import pathlib
import sys

import matplotlib


def main():
    path = pathlib.Path(sys.argv[1])
    notebook = json.loads(path.read_text(encoding="utf-8"))
    matplotlib.use("Agg")
    names = {"__name__": "__main__"}
    for number, cell in enumerate(notebook["cells"], 1):
        if cell["cell_type"] == "code":
            code = compile("".join(cell["source"]), f"{path}, cell {number}",
                           "exec")
            exec(code, names)


if __name__ == "__main__":
    main()
