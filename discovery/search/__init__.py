"""The search: emitters that propose controllers, the archive that says how novel they are, and the loop over generations."""
