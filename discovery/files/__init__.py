"""Files that are either whole or not there: bytes and text, and arrays with a checksum."""
