"""The robot's host side: its firmware as a Python module (:mod:`hero_robot.firmware`) and the fleet's server (:mod:`hero_robot.fleet`)."""
