"""The command `touchwarp` and what its exit codes mean.

0    done
1    `check` only: a hard check of the certificate failed
2    bad input, or an output that cannot be written; one message, nothing written
70   a defect of touchwarp itself, with its traceback
130  interrupted (Ctrl-C, but that is how `view` ends: 0); 143 terminated; no half-written file
     stays behind
"""

from __future__ import annotations

import os
import signal
import sys
import traceback
from collections.abc import Sequence
from types import FrameType
from typing import NoReturn

import click

from touchwarp import __version__
from touchwarp.cli import terminal
from touchwarp.cli.align import align_command
from touchwarp.cli.check import check_command
from touchwarp.cli.demo import demo_command
from touchwarp.cli.goal import goal_command
from touchwarp.cli.info import info_command
from touchwarp.cli.new import new_command
from touchwarp.cli.recordings import recordings_command
from touchwarp.cli.repair import repair_command
from touchwarp.cli.sample import sample_command
from touchwarp.cli.solve import solve_command
from touchwarp.cli.table import table_command
from touchwarp.cli.view import view_command
from touchwarp.errors import TouchwarpError

BAD_INPUT = 2
DEFECT = 70
INTERRUPTED = 130
NO_READER = 141
TERMINATED = 143


@click.group(
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="\b\nExamples:\n"
    "  touchwarp demo -o mug-demo\n"
    "  touchwarp solve mug.toml -o mug.warp\n"
    "  touchwarp check mug.toml mug.warp --html report.html\n"
    "  touchwarp view mug.toml\n"
    "\n'touchwarp COMMAND --help' tells more about each.",
)
@click.version_option(__version__, prog_name="touchwarp", message="%(prog)s %(version)s")
@click.option("-v", "--verbose", is_flag=True, help="Tell each step and its time on stderr.")
def touchwarp(verbose: bool) -> None:
    """Touch one thing, see another: make, check and use warps of retargeted touch."""
    terminal.configure(verbose)


for command in (
    new_command,
    repair_command,
    align_command,
    solve_command,
    check_command,
    sample_command,
    table_command,
    goal_command,
    info_command,
    demo_command,
    view_command,
    recordings_command,
):
    touchwarp.add_command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """The exit code of one call of the command; messages go to stderr."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        # Not click's own main(), which makes of a closed pipe an exit code 1: `check`'s "fail".
        with touchwarp.make_context("touchwarp", given) as context:
            result = touchwarp.invoke(context)
        sys.stdout.flush()
        return result if isinstance(result, int) else 0
    except click.exceptions.Exit as done:
        return done.exit_code
    except click.ClickException as error:
        error.show()
        return BAD_INPUT
    except TouchwarpError as error:
        terminal.say_error(str(error))
        return BAD_INPUT
    except MemoryError:
        terminal.say_error(
            "The machine ran out of memory; ask for a larger --tolerance-mm or end other programs."
        )
        return BAD_INPUT
    except (click.Abort, KeyboardInterrupt):
        terminal.say_error("Interrupted; nothing half-written was left behind.")
        return INTERRUPTED
    except BrokenPipeError:
        # Python's own flush at exit must not complain about it a second time.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return NO_READER
    except Exception:  # the one place where a defect becomes an exit code of its own
        traceback.print_exc()
        terminal.say_error("That is a defect of touchwarp: please report it with the lines above.")
        return DEFECT


def _terminate(number: int, frame: FrameType | None) -> NoReturn:
    raise SystemExit(TERMINATED)


def run() -> NoReturn:
    """The entry point of the installed command."""
    signal.signal(signal.SIGTERM, _terminate)
    code = main()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)  # nothing is left to tell or to put away
    sys.exit(code)
