"""The materials that umax knows by name: read from the program, put into an object's settings."""
from . import program

FACTORS = {"Pa": 1, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "kg/m^3": 1, "s": 1, "ms": 1e-3, "1/s": 1, "%": 0.01, "": 1}
# key of a scene: setting, and how many of its units are one SI unit
SETTINGS = {
    "material.young": ("stiffness", 1e-3),
    "material.poisson": ("poisson", 1),
    "material.density": ("density", 1),
    "material.damping_stiffness": ("damping", 1e3),
    "material.damping_mass": ("drag", 1),
    "limit.stretch": ("stretch", 100),
}
known = {}  # program: [(name, description)]


def names():
    """(name, description) of all; none where the program does not run"""
    path = program.path()
    if path not in known:
        try:
            lines = program.answer(["presets"]).splitlines()
        except program.ProgramError:
            return []
        known[path] = [(words[0], words[1].strip()) for words in (line.split(None, 1) for line in lines)
                       if len(words) == 2]
    return known[path]


def values_of(text):
    """settings by name, of what `umax presets NAME` prints"""
    values = {"damping": 0.0, "drag": 0.0}
    for line in text.splitlines():
        key, _, value = (part.strip() for part in line.partition("="))
        if key not in SETTINGS or line.startswith("#"):
            continue
        number, _, unit = value.strip('"').partition(" ")
        name, factor = SETTINGS[key]
        values[name] = float(number) * FACTORS[unit] * factor
    return values


def apply(name, settings):
    for setting, value in values_of(program.answer(["presets", name])).items():
        setattr(settings, setting, value)
    settings.limit = "hard"
