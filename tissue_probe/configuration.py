"""Where the stock configuration lies: phantoms, nodes' parameters, viewer layouts."""

from pathlib import Path


def stock_configuration(name: str) -> Path:
    """Return the path of a file in ``config/``, in a source tree or an installed package.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    """
    package = Path(__file__).parent
    folders = [package.parent / "config"]
    folders += [folder / "share/tissue_probe/config" for folder in package.parents]
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    raise FileNotFoundError(f"no file {name} in {folders[0]} nor in any installed tissue_probe")
