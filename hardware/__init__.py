"""HeRo+ as open hardware: parametric CAD, bill of materials, wiring and assembly.

Importing this package needs nothing beyond the project's own dependencies; the modules in :mod:`hardware.cad`,
:mod:`hardware.render` and :mod:`hardware.checks` need the extra ``hardware`` (build123d, trimesh, vtk).
Licence: CERN-OHL-W-2.0, see ``hardware/LICENSE``.
"""
