"""What a trajectory looks like, without display or GPU.

- :func:`render` and :class:`Renderer`: the colour picture of one moment.
- :func:`videos`: the paper's greyscale videos of a whole batch, compiled.
- :func:`trails`: fading paths to lay under them.
- :func:`save_video`: one run as a GIF or an MP4; :func:`pictures` yields its frames.
"""

from swarm_envs.rendering.film import pictures, save_video
from swarm_envs.rendering.greyscale import frame_indices, videos
from swarm_envs.rendering.picture import Renderer, render
from swarm_envs.rendering.trails import trails
from swarm_envs.rendering.view import View, view_of

__all__ = ["Renderer", "View", "frame_indices", "pictures", "render", "save_video", "trails", "videos", "view_of"]
