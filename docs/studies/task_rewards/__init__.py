"""What does each task pay its own behaviour, and random controllers?"""
