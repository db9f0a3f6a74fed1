"""Scene files of umax: tables of keys as TOML. Knows nothing of Blender."""


def value_text(value):
    """a TOML value: true, 3, 0.5, "text", [1, 2], { a = 1 }"""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str):
        escaped = "".join(f"\\u{ord(c):04x}" if ord(c) < 32 or c in '"\\' else c for c in value)
        return f'"{escaped}"'
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {value_text(item)}" for key, item in value.items()) + " }"
    return "[" + ", ".join(value_text(item) for item in value) + "]"


def scene_text(tables):
    """tables: (header, {key: value}) pairs, as in ("body.cow", {"cage.cells": 365}); None: the key is not given"""
    lines = []
    for header, keys in tables:
        lines.append(f"[{header}]")
        lines += [f"{key} = {value_text(value)}" for key, value in keys.items() if value is not None]
        lines.append("")
    return "\n".join(lines)


def plain_names(names):
    """names that tables and files can have, all different: {name: plain name}"""
    plain = {}
    for name in names:
        start = "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name) or "_"
        candidate, number = start, 2
        while candidate.lower() in (used.lower() for used in plain.values()):
            candidate, number = f"{start}_{number}", number + 1
        plain[name] = candidate
    return plain
