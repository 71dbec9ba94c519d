"""The command ``mrsfi new``: a project of a team's own."""

from pathlib import Path

import click


@click.command(name="new")
@click.argument("name", metavar="NAME")
@click.option("--from", "source", metavar="MISSION", help="Begin with the models of a mission.")
@click.option(
    "--import",
    "published",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    metavar="FILE",
    help="Begin with a model published for the paper's prototype.",
)
@click.option(
    "--node",
    metavar="ws://…",
    help="Also write [node], what your own node hears and says, from the topics of a server.",
)
@click.option(
    "--install",
    type=click.Choice(["wheel", "index", "git"]),
    default="wheel",
    show_default=True,
    help="From what build servers install mrsfi: a wheel in vendor/, pip's package index, or the "
    "git repository of this mrsfi.",
)
def command(
    name: str, source: str | None, published: Path | None, node: str | None, install: str
) -> None:
    """Make the folder NAME of a new project, ready for git, with a mission NAME that flies.

    It holds the metamodels, for Eclipse and to be extended; a small mission and its pool, as models
    and as a script that builds them; a campaign file; generated code; a Makefile; and what two
    common build servers need to fly the kept weaknesses on each change. mrsfi.toml says where all
    of it is: commands work from any folder inside. If this mrsfi was installed from a wheel,
    vendor/ has a copy, which the build servers install; `make wheel` in mrsfi's tree builds one.

    \b
    Examples:
      mrsfi new demo && cd demo && make evolve
      mrsfi new harbour --from models/uuv_sampling      begin with a mission that there is
      mrsfi new harbour --import published.xmi          begin with a model of the paper's prototype
      mrsfi new harbour --node ws://127.0.0.1:9090      begin with the topics of your robots
    """
    from mrsfi.starting import start, wheel_of

    if source is not None and published is not None:
        raise click.UsageError("--from and --import exclude each other")
    folder = start(name, source, published, node, install)
    click.echo(f"made       {folder}/, with the mission models/{name}")
    if install == "wheel" and not wheel_of(folder).exists():
        click.echo(f"needed     {wheel_of(folder)} for build servers: `make wheel` builds it")
    click.echo(f"next       cd {folder} && make evolve")
    click.echo(f"then       mrsfi keep runs/{name}-a-1 --weakness 1 && make regressions")
