"""The contact law for discs in a polygon, compiled: speculative contacts solved by sequential impulses.

Each robot has a desired velocity; contact changes these as little as possible in the mass metric. A pair may close its gap within the
tick and no more, so a full tick of 0.1 s needs no substeps: with v_n the relative velocity along the normal, v_n >= -gap / dt.
Discs and straight walls only get farther apart than the linearised gap says, whatever the normal, so a solved tick does not overlap.
A tick is solved twice: first to see where it leads, then with the normals and headings of its middle, which makes sliding and
turning contacts accurate to second order.
Friction is Coulomb's on the velocity of the contact points, spins included, bounded by the normal impulse.

A tick costs what happens in it: a robot with nothing near drives its arc; one with a single wall near is solved in closed form, since
nobody else is concerned; the others, the contact island, are solved together.

- ``engine``: a tick, which assigns each robot to one of these three;
- ``broad_phase``: which contacts could close within it; ``contact``: one of them, as a row of numbers;
- ``motion``: a robot without contact; ``single_wall``: the closed form; ``island`` and ``solver``: the robots solved together.
"""
