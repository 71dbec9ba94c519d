"""The command ``mrsfi``: its subcommands, the topics of its help, and its exit codes.

Subcommands are listed here with their help and imported when they are called. Only
``CommandGroup.invoke`` turns errors into exit codes. ``main`` is the entry point.
"""

import gc
import signal
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from threading import current_thread, main_thread
from typing import Any, cast

import click

from mrsfi_runtime.cli.terminal import steady_output
from mrsfi_runtime.errors import LIMITED, MrsfiError, UsageError, expected
from mrsfi_runtime.project_file import metamodels_chosen

_INTERRUPTED = 130

_COMMANDS: Mapping[str, tuple[str, str]] = {
    "new": ("models", "Make a new project with a mission that flies."),
    "validate": ("models", "Check the models of a mission."),
    "generate": ("models", "Generate the middleware of a mission from its models."),
    "simulate": ("flights", "Fly a mission once, with or without faults."),
    "evolve": ("campaigns", "Search for faults that break the goals of a mission."),
    "weaknesses": ("campaigns", "Print the weaknesses of a campaign: its main result."),
    "monitors": ("campaigns", "Print which checks would have caught the weaknesses in time."),
    "show": ("campaigns", "Draw how a weakness breaks its goal."),
    "explain": ("flights", "Find out which faults of a specification break which goal."),
    "replay": ("flights", "Fly evaluations of a campaign again and compare."),
    "report": ("campaigns", "Write figures, tables and page of a campaign."),
    "keep": ("regressions", "Keep a weakness, with limits, beside the models of its mission."),
    "decide": ("regressions", "Accept a weakness, plan its repair, or call it a duplicate."),
    "check": ("regressions", "Fly every kept weakness; fail if one exceeds its limit."),
    "compare": ("compare", "Compare two campaigns of a mission, or search algorithms on it."),
    "history": ("compare", "Print which weaknesses came, went and stayed over campaigns."),
    "confirm": ("campaigns", "Fly the weaknesses of a campaign in another world, such as Gazebo."),
    "pack": ("campaigns", "Pack a campaign into one file that can be repeated elsewhere."),
    "bridge": ("flights", "Run a rosbridge server for simulators and collective intelligences."),
    "import": ("models", "Make a mission folder from a model of the paper's prototype."),
    "requirements": ("models", "Read requirements from ReqIF, or write their results into it."),
    "rename": ("models", "Give elements of a mission other IDs, in all files."),
    "diff": ("models", "Print the difference between two models."),
    "help": ("main", "Print the help of a command, or of a topic: bus, words."),
}
"""Module and one-line help of each subcommand, so that ``mrsfi --help`` imports none."""


_BUS = """\
A mission has two sides: the collective intelligence (CI), which commands the
robots, and the simulation. With --engine rosbridge they exchange ROS messages
through a rosbridge server (the bus); mrsfi bridge is one that needs no ROS.
Either side can be your own:

  --engine rosbridge                             both sides are mrsfi's
  --world "python world.py {url}"                your simulator, mrsfi's CI
  --engine rosbridge --url ws://… --side ci      the same, at your server
  --engine rosbridge --url ws://… --side simulation    mrsfi's simulation alone
  --side injector --node "python node.py {url}"  your node as the CI
  --side injector --url ws://… --world built-in  your node, at your server
  --side injector --url ws://…                   your node and simulator there

mrsfi.toml, at the root of the project, states the version of ROS and the
topics of your node; mrsfi new NAME --node URL writes it from a server:

  [project]
  ros = 2

  [[node.tells]]                    # messages that your node receives
  topic = "/{robot}/odom"
  type = "nav_msgs/Odometry"
  fields = { "pose.pose.position.x" = "x", "pose.pose.position.y" = "y" }

  [[node.obeys]]                    # messages that your node sends
  topic = "/{robot}/cmd_vel"
  type = "geometry_msgs/Twist"
  fields = { "linear.x" = "speed", "angular.z" = "turn" }

All else is an option of each command that flies. A campaign records them for
replay, explain and evolve --resume. More: docs/bus.md, docs/node.md
"""


class CommandGroup(click.Group):
    """Subcommands, each imported when it is called; all errors leave through ``invoke``."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 - click's signature
        """Return the names in the order in which a user needs them."""
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002 - click's signature
        """Import one subcommand."""
        if cmd_name not in _COMMANDS:
            return None
        module = import_module(f"mrsfi_runtime.cli.{_COMMANDS[cmd_name][0]}")
        command = getattr(module, f"{cmd_name}_command")
        return command if isinstance(command, click.Command) else cast("click.Command", command())

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002 - click's signature
        """List the subcommands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in _COMMANDS.items()])

    def invoke(self, ctx: click.Context) -> Any:
        """Run a subcommand; if it raises an error, print it and end with its exit code."""
        try:
            with metamodels_chosen():
                return super().invoke(ctx)
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except BaseException as error:  # noqa: BLE001 - every error becomes an exit code
            ctx.exit(_report(error, is_traced=ctx.params["traceback"]))


def _report(error: BaseException, *, is_traced: bool) -> int:
    if KeyboardInterrupt in (type(error), type(error.__cause__)):  # Python wraps some in imports
        click.echo("mrsfi: interrupted", err=True)
        return _INTERRUPTED
    if is_traced:
        sys.__excepthook__(type(error), error, error.__traceback__)
    if isinstance(error, MemoryError) or str(error) == "can't start new thread":
        error = UsageError(f"{str(error) or 'no more memory'}: {LIMITED}")
    if isinstance(error, MrsfiError):
        click.echo(f"mrsfi: {error}", err=True)
        return error.exit_code
    advice = "" if is_traced else "; run `mrsfi --traceback …` to see where, and report it"
    click.echo(f"mrsfi: a defect of mrsfi: {type(error).__name__}: {error}{advice}", err=True)
    return MrsfiError.exit_code


@click.group(
    cls=CommandGroup,
    commands=dict.fromkeys(_COMMANDS),  # for suggestions when a name is misspelt
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option("--traceback", is_flag=True, help="On an error, print where in the code it occurred.")
@click.version_option(package_name="mrsfi", help="Show the version and end.")
def cli(traceback: bool) -> None:
    """Find the faults that break a multi-robot mission.

    Two models in models/NAME/ describe a mission and the faults that could occur in it. From them
    mrsfi generates the mission's middleware. It flies the mission in simulation and searches for
    weaknesses: minimal sets of faults, with times and values, that break a goal.

    \b
    In this order:
      mrsfi validate uuv_sampling              check the models
      mrsfi generate uuv_sampling              write generated/uuv_sampling/*.py
      mrsfi simulate uuv_sampling              fly once without faults
      mrsfi evolve uuv_sampling --case a       search; prints the weaknesses of each goal
      mrsfi weaknesses runs/uuv_sampling-a-1   print all of them: the main result
      mrsfi show runs/uuv_sampling-a-1 6       draw how weakness 6 breaks its goal
      mrsfi explain runs/uuv_sampling-a-1      explain the worst specification
      mrsfi help words                         every term of mrsfi, with an example
      eval "$(_MRSFI_COMPLETE=bash_source mrsfi)"    complete words with the Tab key in bash

    Results go to standard output, progress to standard error.

    \b
    Exit codes:
      0  done                                6  the mission's own code failed
      1  a defect of mrsfi                   7  a replay differs from its record
      2  wrong usage                         8  messages were lost
      3  a model that cannot be used         9  a campaign folder that cannot be used
      4  generation impossible, or stale    10  a kept weakness exceeds its limit
      5  a fault specification that         11  a weakness is neither kept nor decided on
         cannot be flown                   130  interrupted
    """


@click.command(name="help")
@click.argument("topic", metavar="[COMMAND|TOPIC]", default="help")
@click.pass_context
def help_command(ctx: click.Context, topic: str) -> None:
    """Print the help of a command, or of a topic.

    \b
    Examples:
      mrsfi help evolve
      mrsfi help bus       topic: connect your own simulator or node
      mrsfi help words     topic: every term of mrsfi, with an example
    """
    click.echo(help_text(ctx, topic))


def help_text(ctx: click.Context, topic: str) -> str:
    """Return the help of a command or of a topic, as wide as the terminal."""
    formatter = ctx.make_formatter()
    if topic == "bus":
        from mrsfi_runtime.cli.options import OF_BUS

        simulate = cast("click.Command", cli.get_command(ctx, "simulate"))
        formatter.write(_BUS)
        with formatter.section("Options"):
            records = (each.get_help_record(ctx) for each in simulate.params if each.name in OF_BUS)
            formatter.write_dl([*filter(None, records)])
    elif topic == "words":
        from mrsfi_runtime.glossary import TERMS

        for term in TERMS:
            with formatter.section(term.name):
                formatter.write_text(f"{term.meaning} Example: {term.example}")
                formatter.write_text(f"Related terms: {term.neighbour}")
    elif (command := cli.get_command(ctx, topic)) is not None:
        return command.get_help(click.Context(command, info_name=topic, parent=ctx.parent))
    else:
        raise UsageError(f"found '{topic}'; {expected(topic, ('bus', 'words', *_COMMANDS))}")
    return formatter.getvalue().rstrip()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line of this process, or the given words; return the exit code."""
    output = steady_output()
    gc.set_threshold(50_000)  # to look for garbage after 700 new objects takes 9 % of a search
    if current_thread() is main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends it like Ctrl-C
    try:
        code = cli.main(args=arguments, prog_name="mrsfi", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except click.Abort:
        return _INTERRUPTED
    decided = code if isinstance(code, int) else 0
    sys.stdout.flush()
    if output is None or output.error is None or isinstance(output.error, BrokenPipeError):
        return decided
    click.echo(f"mrsfi: standard output cannot be written: {output.error.strerror}", err=True)
    return decided or UsageError.exit_code


if __name__ == "__main__":
    sys.exit(main())
