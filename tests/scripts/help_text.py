# SPDX-License-Identifier: MIT
"""What the program prints with --help, for the tests of what is made from the same commands."""
import re
import subprocess


class Help:
    """The help of a command; words are those behind "alidade"."""

    def __init__(self, program, words):
        self.words = words
        text = subprocess.run([program, *words, "--help"], check=True, capture_output=True, text=True).stdout
        self.text = text
        self.flags, self.choices, self.commands = [], {}, []
        section = ""
        for line in text.split("\n"):
            if re.fullmatch(r"\S.*:", line):
                section = line[:-1]
            entry = re.match(r"  (\S+)", line)
            if not entry:
                continue
            if section == "Subcommands":
                self.commands.append(entry[1])
            elif entry[1].startswith("-"):
                names = entry[1].split(",")
                self.flags += names
                values = re.match(r"  \S+ \w+:\{([^}]*)\}", line)
                if values:
                    self.choices.update({name: values[1].split(",") for name in names})


def all_helps(program, words=()):
    """The program, its groups and its commands, each before those inside of it."""
    here = Help(program, list(words))
    return [here] + [inner for name in here.commands for inner in all_helps(program, [*words, name])]
