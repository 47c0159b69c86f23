"""Generate ``messages_pb2.py`` and its types from ``messages.proto``: ``python -m hw.kortex.generate``.

The generator's check that the installed ``protobuf`` is no older than itself is left out: nothing here
depends on it, and the driver then runs with every ``protobuf`` from 4.25 on, whatever else is installed.
"""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

from dynamics.errors import PalpateError

FOLDER = Path(__file__).parent
ROOT = FOLDER.parent.parent  # the messages' name in protobuf's registry is their path from here
OUTPUTS = ("messages_pb2.py", "messages_pb2.pyi")


def generate() -> dict[str, str]:
    """Return the text of each generated file by its name.

    Raises:
        PalpateError: if ``grpcio-tools`` is not installed or refuses the messages.
    """
    try:
        from grpc_tools import protoc
    except ImportError:
        raise PalpateError("generating the messages needs the package grpcio-tools") from None
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        options = [f"-I{ROOT}", f"--python_out={folder}", f"--pyi_out={folder}", "hw/kortex/messages.proto"]
        if protoc.main(["protoc", *options]) != 0:
            raise PalpateError("messages.proto was refused by the protobuf compiler (its words are above)")
        python, types = (Path(folder, "hw", "kortex", name).read_text() for name in OUTPUTS)
    python = re.sub(r"^from google\.protobuf import runtime_version.*\n", "", python, flags=re.MULTILINE)
    python = re.sub(r"^_runtime_version\.Validate\w+\((?s:.*?)^\)\n", "", python, flags=re.MULTILINE)
    python = re.sub(r"^# Protobuf Python Version:.*\n", "", python, flags=re.MULTILINE)
    types = types.replace("_Mapping]", "_Mapping[str, object]]")
    return dict(zip(OUTPUTS, (python, types), strict=True))


def main() -> None:
    """Write the generated files beside the messages."""
    for name, text in generate().items():
        (FOLDER / name).write_text(text)
        sys.stdout.write(f"{FOLDER / name}\n")


if __name__ == "__main__":
    main()
