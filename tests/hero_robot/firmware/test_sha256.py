from __future__ import annotations

import hashlib
import hmac

from hypothesis import given, settings
from hypothesis import strategies as st

from hero_robot.firmware.library import load


@settings(max_examples=300, deadline=None)
@given(st.binary(min_size=32, max_size=32), st.binary(max_size=400))
def test_tags_equal_those_of_hashlib(key: bytes, data: bytes) -> None:
    library, ffi = load()
    tag = ffi.new("uint8_t[32]")
    library.hero_hmac(key, data, len(data), tag)
    assert bytes(tag) == hmac.new(key, data, hashlib.sha256).digest()
