"""The command ``mrsfi show``: how goals break, in words and in pictures."""

from pathlib import Path

import click


@click.command(name="show")
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.argument("number", metavar="[N]", required=False, type=click.IntRange(1))
def command(run: Path, number: int | None) -> None:
    """Draw how goals break, and say so: the least that breaks each goal, or weakness N.

    RUN is the folder of a campaign that looked for what breaks which goal, N a number of mrsfi
    weaknesses. Its mildest form that is known is flown on the campaign's own copy of the code, and
    drawn in time, faults above the goals that they break, and in space, as robots flew and as they
    were believed to. What is drawn already, and not older than the campaign's record, is not drawn
    again.

    \b
    Examples:
      mrsfi show runs/uuv_sampling-a-1
      mrsfi show runs/uuv_sampling-a-1 6

    Written into the folder: figures/weakness_* as PNG and SVG, and their numbers into tables/.
    """
    from mrsfi.campaign_folders import open_campaign
    from mrsfi.explaining import harvested, show
    from mrsfi_runtime.cli.ways import print_verdicts

    with open_campaign(run) as campaign:
        found = harvested(campaign)
        if number is None:
            print_verdicts(campaign, found)
        for each in show(campaign, number):
            click.echo(f"{each.way.number}  {each.title}")
            for line in (*each.sentences, *each.figures):
                click.echo(f"    {line}")
            click.echo()
