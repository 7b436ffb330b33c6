"""A process of `situ-bench serve`: one request a line, one answer a line. It needs the standard library alone."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import weakref
from pathlib import Path
from typing import Any

#: The version of the requests and answers that this package speaks.
PROTOCOL = 1
#: The variable of the environment that names the program, where it is not on the path.
VARIABLE = "SITU_BENCH"
#: Seconds that the program is given to end by itself when its input ends.
GRACE = 5.0


class ServeError(Exception):
    """A request that could not be done: the message says what would be right, and the episode is as it was.

    Also a program that cannot be found, or that has ended.
    """


def find_program() -> str:
    """The program: what `SITU_BENCH` names, or the one beside this Python, or the one on the path."""
    named = os.environ.get(VARIABLE)
    if named:
        return named
    beside = Path(sys.executable).parent / "situ-bench"
    found = str(beside) if beside.is_file() else shutil.which("situ-bench")
    if found is None:
        raise ServeError(f"the program situ-bench is not there: install the wheel, or name it in {VARIABLE}")
    return found


def _end(process: subprocess.Popen[str]) -> None:
    """Ends a process; nothing of it is left running."""
    try:
        if process.stdin is not None:
            process.stdin.close()
    except OSError:
        pass
    try:
        process.wait(GRACE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if process.stdout is not None:
        process.stdout.close()


class Client:
    """A process of `situ-bench serve` with these arguments. It ends with `close`, or when nobody holds it any more."""

    def __init__(self, *arguments: str, program: str | None = None) -> None:
        command = [program or find_program(), "serve", *arguments]
        # A session of its own: the interrupt of a terminal is for Python to hear.
        try:
            self._process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8", start_new_session=True
            )
        except OSError as error:
            raise ServeError(f"{command[0]} cannot be started: {error}") from error
        self._asked = 0
        self._finalizer = weakref.finalize(self, _end, self._process)
        try:
            self.ask("hello", protocol=PROTOCOL)
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid

    @property
    def is_closed(self) -> bool:
        """Whether the process has been ended."""
        return not self._finalizer.alive

    def ask(self, do: str, **keys: Any) -> dict[str, Any]:
        """The answer to a request, without its number."""
        if self.is_closed:
            raise ServeError("this process has been ended")
        stdin, stdout = self._process.stdin, self._process.stdout
        if stdin is None or stdout is None:
            raise ServeError("this process has no pipes")
        self._asked += 1
        try:
            line = json.dumps({"id": self._asked, "do": do, **keys}, allow_nan=False)
        except ValueError as error:
            raise ServeError(f"{do}: expected finite numbers ({error})") from error
        try:
            stdin.write(line + "\n")
            stdin.flush()
            said = stdout.readline()
        except OSError as error:
            self.close()
            raise ServeError(f"{do}: the program has ended ({error})") from error
        except BaseException:
            # Somebody was interrupted half-way: nobody knows which answer comes next.
            self.close()
            raise
        if not said:
            self.close()
            raise ServeError(f"{do}: the program has ended with status {self._process.returncode}")
        answer: dict[str, Any] = json.loads(said)
        if "error" in answer:
            raise ServeError(answer["error"])
        if answer.pop("id") != self._asked:
            self.close()
            raise ServeError(f"{do}: the answer is to another request")
        return answer

    def close(self) -> None:
        """Ends the process. To end it twice is no mistake."""
        self._finalizer()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
