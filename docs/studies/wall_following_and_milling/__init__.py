"""How often do wall following and milling arise from random controllers, with and without the paper's measurements?"""
