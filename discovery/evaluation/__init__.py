"""How good representations and searches are: one command each, each with figures, a CSV and a JSON."""
