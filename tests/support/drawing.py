from pathlib import Path

from matplotlib.figure import Figure

from mrsfi_runtime.analysis.plots import rendered


def save(figure: Figure, stem: Path) -> tuple[Path, ...]:
    files = {stem.with_suffix(suffix): content for suffix, content in rendered(figure).items()}
    for path, content in files.items():
        path.write_bytes(content)
    return tuple(files)
