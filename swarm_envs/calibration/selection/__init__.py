"""What drive, sensor and contact share: how an effect is named, and how certain its numbers are."""
