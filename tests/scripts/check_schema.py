#!/usr/bin/env python3
"""Whether results.json files are laid out as src/experiment/results.schema.json says.

    check_schema.py RESULTS.json...

Prints each place that is not, with what is wrong there; exit code 1 if there is any.
"""
import json
import pathlib
import sys

import jsonschema

SCHEMA = pathlib.Path(__file__).resolve().parents[2] / "src/experiment/results.schema.json"


def innermost(error):
    """Where alternatives are allowed, what is wrong in each of them."""
    return [leaf for inner in error.context for leaf in innermost(inner)] if error.context else [error]


def refuse_constant(name):
    raise ValueError(f"{name} is no JSON")


def main():
    schema = json.loads(SCHEMA.read_text())
    jsonschema.Draft7Validator.check_schema(schema)
    validator = jsonschema.Draft7Validator(schema)
    wrong = 0
    for file in sys.argv[1:]:
        results = json.loads(pathlib.Path(file).read_text(), parse_constant=refuse_constant)
        for error in validator.iter_errors(results):
            wrong += 1
            for leaf in innermost(error):
                print(f"{file}: /{'/'.join(str(key) for key in leaf.absolute_path)}: {leaf.message[:200]}")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
