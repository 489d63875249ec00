"""Where recorded logs, graphs, clouds and maps lie."""
import os
import pathlib


def data_folder(root):
    """$LOOPSTONE_DATA, else shared/data beside the repository."""
    return pathlib.Path(os.environ.get("LOOPSTONE_DATA", root.parent / "shared/data"))
