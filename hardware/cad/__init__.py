"""Parametric parts, one module each; every builder takes :class:`hardware.dimensions.Hardware` and returns a build123d solid.

Parts stand where they sit in the robot (left side, for those that come in pairs); :mod:`hardware.cad.catalogue` knows how each lies on
the print bed and :mod:`hardware.cad.assembly` puts the robot together.
"""
