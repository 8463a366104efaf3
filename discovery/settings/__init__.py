"""What a run may be told: types and bounds of every setting.

Values and what they mean stand in ``configs/``, once; the classes here give them types and refuse unknown keys and numbers out of bounds.

A setting that is added later takes a neutral value, with which everything is as it was before: a config that lacks it is read with that
value. One that is renamed is added to :data:`discovery.settings.former_names.KEYS`, under which earlier configs and command lines still
give it.
"""

from discovery.settings.groups import (
    LOCATION_KEYS,
    ClusteringSettings,
    DatasetSettings,
    ReportSettings,
    SearchSettings,
    Settings,
    TrackerSettings,
)  # fmt: skip
from discovery.settings.reading import flat, identity, read_settings, setting_names, to_yaml
from discovery.settings.representation import (
    REPRESENTATIONS,
    EncoderSettings,
    HandCraftedSettings,
    SimCLRSettings,
    TrainedSettings,
    TripletSettings,
    UntrainedSettings,
)  # fmt: skip

__all__ = [
    "LOCATION_KEYS", "REPRESENTATIONS", "ClusteringSettings", "DatasetSettings", "EncoderSettings", "HandCraftedSettings", "ReportSettings",
    "SearchSettings", "Settings", "SimCLRSettings", "TrackerSettings", "TrainedSettings", "TripletSettings", "UntrainedSettings", "flat",
    "identity", "read_settings", "setting_names", "to_yaml",
]  # fmt: skip
