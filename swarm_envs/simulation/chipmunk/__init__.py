"""The contact law by Chipmunk: discs, boxes and polygons, driven from compiled code.

``cpSpaceStep`` moves bodies with the velocities of the step before and solves contacts afterwards, so a desired velocity
written into a body before the step would move it unsolved. Here the bodies' position function does nothing; a substep is: write the desired
velocities, step (find contacts, solve), then move every body with the solved velocity. The solver has the last word and a command acts
without delay.

A tick has as many substeps as its contacts need: none where nothing is near, few for walls, whose normals stay. What contact did in the
substep before tells when blocked robots will touch others, and where they will be and head in the substep's middle: there the
solver finds contacts and desired velocities, which makes sliding and turning accurate to second order.

- ``engine``: a tick; ``substeps``: how many it needs; ``prediction``: when robots will touch, judging by the substep before;
- ``spaces``: Chipmunk's objects; ``calls``: its C functions, called from compiled code.
"""
