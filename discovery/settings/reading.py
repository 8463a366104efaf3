"""From a composed config to typed settings, and back to YAML."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from typing import Any

from omegaconf import MISSING, DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from discovery.errors import DiscoveryError
from discovery.settings.checks import check
from discovery.settings.former_names import rename_keys
from discovery.settings.groups import LOCATION_KEYS, Settings
from discovery.settings.representation import REPRESENTATIONS


def read_settings(config: DictConfig) -> Settings:
    """Turn a composed config into typed settings; keys may have the names of earlier versions.

    Raises:
        DiscoveryError: On an unknown or missing key, a wrong type, or a number out of bounds.
    """
    config = config.copy()
    rename_keys(config)
    method = OmegaConf.select(config, "representation.method")
    if method not in REPRESENTATIONS:
        raise DiscoveryError(f"representation.method: given {method!r}, expected {' or '.join(REPRESENTATIONS)}")
    schema = OmegaConf.structured(Settings)
    schema.representation = OmegaConf.structured(REPRESENTATIONS[method])
    try:
        settings: Settings = OmegaConf.to_object(OmegaConf.merge(schema, config))  # type: ignore[assignment]
    except OmegaConfBaseException as error:
        key = error.full_key or "config"
        raise DiscoveryError(f"{key}: {str(error).splitlines()[0]}; see configs/ for the keys and their types") from None
    check(settings)
    return settings


def flat(settings: Settings) -> dict[str, Any]:
    """Return every setting under its dotted key."""

    def walk(part: Any, prefix: str) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            found |= walk(value, f"{prefix}{field.name}.") if dataclasses.is_dataclass(value) else {prefix + field.name: value}
        return found

    return walk(settings, "")


def setting_names(part: Any = Settings, prefix: str = "") -> list[str]:
    """Return the dotted key of every setting."""
    names: list[str] = []
    for field in dataclasses.fields(part):
        if field.name == "representation":
            names += sorted({name for kind in REPRESENTATIONS.values() for name in setting_names(kind, "representation.")})
            continue
        default = field.default_factory() if field.default_factory is not dataclasses.MISSING else None
        names += setting_names(default, f"{prefix}{field.name}.") if dataclasses.is_dataclass(default) else [prefix + field.name]
    return names


def identity(settings: Settings) -> str:
    """Return what a run with these settings is known by; the order of keys changes nothing."""
    return hashlib.sha256(json.dumps(_telling(settings), sort_keys=True).encode()).hexdigest()[:16]


def to_yaml(settings: Settings) -> str:
    """Return the settings as YAML, without those that say only where and those that have their neutral value."""
    return OmegaConf.to_yaml(OmegaConf.create(_telling(settings)))


def _telling(settings: Settings) -> dict[str, Any]:
    """Return the settings, group by group, without those that say only where and those that have their neutral value."""

    def walk(part: Any) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for field in dataclasses.fields(part):
            value, neutral = getattr(part, field.name), field.default
            if dataclasses.is_dataclass(value):
                if inside := walk(value):
                    found[field.name] = inside
            elif neutral in (dataclasses.MISSING, MISSING) or value != neutral:
                found[field.name] = value
        return found

    return {key: value for key, value in walk(settings).items() if key not in LOCATION_KEYS}
