"""Concealed effects: physics the nominal equations do not hold, in forms chosen without regard to any library."""
