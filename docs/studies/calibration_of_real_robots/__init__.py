"""What did the simulation get wrong about three real robots?"""
