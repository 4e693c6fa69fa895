"""Where stock files lie: phantoms, nodes' parameters, viewer layouts; example recordings."""

from pathlib import Path


def stock_configuration(name: str) -> Path:
    """Return the path of a file in ``config/``, in a source tree or an installed package.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    """
    return _stock("config", name)


def stock_example(name: str) -> Path:
    """Return the path of a recording in ``examples/``, in a source tree or an installed package.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    """
    return _stock("examples", name)


def _stock(kind: str, name: str) -> Path:
    package = Path(__file__).parent
    folders = [package.parent / kind]
    folders += [folder / "share/tissue_probe" / kind for folder in package.parents]
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    raise FileNotFoundError(f"no file {name} in {folders[0]} nor in any installed tissue_probe")
