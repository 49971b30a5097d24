"""The reference of the command: what `--help` says of each subcommand."""

import re

from .place import OUT, fence, insert, run


def write():
    overview = run(["stiction", "--help"], OUT)
    text = fence(overview, "text")
    for name, _ in listed(overview):
        text += f"\n## `stiction {name}`\n\n"
        help_of = run(["stiction", name, "--help"], OUT)
        below = listed(help_of)
        text += fence(help_of, "text")
        for inner, _ in below:
            text += f"\n### `stiction {name} {inner}`\n\n" + fence(run(["stiction", name, inner, "--help"], OUT), "text")
    insert("reference/commands", "commands", text)


def listed(text):
    """Names and sentences of the subcommands that a help text lists."""
    part = re.search(r"^Commands:\n((?:  .*\n)+)", text, re.MULTILINE)
    rows = re.findall(r"^  (\S+) +(.*)", part[1], re.MULTILINE) if part else []
    return [(name, sentence) for name, sentence in rows if name != "help"]
