"""Residuals: what a model leaves, on what that depends, and corrections of it where no listed effect explains it."""
