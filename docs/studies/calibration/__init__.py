"""How often are effects that are hidden in logs found?"""
