"""The sensor: the likelihood of a log's detections, and the effects that explain them."""
