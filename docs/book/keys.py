"""All keys of the case file, from `stiction schema`."""

import json

from .place import OUT, insert, run


def write():
    schema = json.loads(run(["stiction", "schema"], OUT))
    sections, seen = [], {}
    table(schema, [], sections, seen)
    insert("reference/case-file-keys", "keys", "\n".join(sections))


def heading(path):
    """How a table is written in TOML."""
    return "".join(path).lstrip(".") or "The case"


def slug(path):
    return "key-" + "".join(c if c.isalnum() else "-" for c in heading(path)).strip("-").lower()


def table(schema, path, sections, seen):
    """Adds a section for a table and those below it; a table that was described before is linked."""
    head = heading(path)
    level = min(2 + max(len(path) - 1, 0), 4)
    lines = [f"({slug(path)})=", f"{'#' * level} {'`' + head + '`' if path else head}", "", schema.get("description", ""), ""]
    choice = [one["required"][0] for one in schema.get("oneOf", []) if "required" in one]
    if choice:
        lines += ["Exactly one of " + ", ".join(f"`{name}`" for name in choice) + " is given.", ""]
    rows, below = [], []
    for name, key in schema.get("properties", {}).items():
        kinds, tables = kind(key, path + [f".{name}"])
        links = []
        for place, inner in tables:
            known = json.dumps({**inner, "description": ""}, sort_keys=True)
            if known not in seen:
                seen[known] = place
                below.append((place, inner))
            links.append(f"[`{heading(seen[known])}`](#{slug(seen[known])})")
        kinds = ", ".join(dict.fromkeys(kinds + links))
        needed = "**required**" if name in schema.get("required", []) else default(key)
        rows.append(f"| `{name}` | {kinds} | {needed} | {cell(key.get('description', ''))}{choices(key)} |")
    if rows:
        lines += ["| key | value | default | meaning |", "|---|---|---|---|", *rows, ""]
    sections.append("\n".join(lines))
    for place, inner in below:
        table(inner, place, sections, seen)


def kind(schema, path):
    """What a value may be, in words, and the tables among that with their paths."""
    if "anyOf" in schema:
        words, tables = [], []
        for one in schema["anyOf"]:
            more, found = kind(one, path)
            words += more
            tables += found
        return list(dict.fromkeys(words)), tables
    what = schema.get("type")
    if what == "object":
        inner = schema.get("additionalProperties")
        if isinstance(inner, dict):
            return [], [(path + [".NAME"], inner)]
        return [], [(path, schema)]
    if what == "array":
        inner = schema["items"]
        if inner.get("type") == "object" and isinstance(inner.get("additionalProperties"), bool):
            return ["list of tables"], [(path, inner)]
        words, tables = kind(inner, path)
        low, high = schema.get("minItems"), schema.get("maxItems")
        count = f"{low} " if low == high and low else ""
        return [f"list of {count}{' or '.join(plural(w) for w in words)}"], tables
    if what == ["number", "string"]:
        return ["number or expression"], []
    if what == "string" and "oneOf" in schema:
        return [" or ".join(f'`"{one["const"]}"`' for one in schema["oneOf"])], []
    words = {"string": "text", "number": "number", "integer": "whole number", "boolean": "`true` or `false`"}[what]
    return [words + bounds(schema)], []


def plural(words):
    for one, many in (("number", "numbers"), ("text", "texts"), ("list of", "lists of")):
        if words.startswith(one):
            return many + words[len(one) :]
    return words.replace("whole number", "whole numbers", 1)


def bounds(schema):
    parts = []
    for key, sign in (("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"), ("exclusiveMaximum", "<")):
        if key in schema:
            parts.append(f"{sign} {schema[key]:.15g}")
    return " " + ", ".join(parts) if parts else ""


def default(schema):
    return f"`{json.dumps(schema['default'], ensure_ascii=False)}`" if "default" in schema else ""


def choices(schema):
    """What each word of a choice means."""
    options = [one for one in [schema, *schema.get("anyOf", [])] if one.get("type") == "string" and "oneOf" in one]
    said = [f'`"{o["const"]}"`: {cell(o["description"])}' for one in options for o in one["oneOf"] if o.get("description")]
    return " (" + "; ".join(said) + ")" if said else ""


def cell(text):
    """Text within a cell of a table: brackets and bars mean themselves."""
    for mark in "\\|[]{}<>*_$":
        text = text.replace(mark, "\\" + mark)
    return text
