"""Identifiers of effects that a diagnosis may name, by block."""

BY_BLOCK = {
    "actuation": (
        "coulomb_friction",
        "stribeck_friction",
        "viscous_leg",
        "backlash",
        "force_deadzone",
        "command_delay",
        "weak_leg",
        "force_gain",
        "saturation",
    ),
    "mechanism": ("anchor_error", "ring_mass", "leg_compliance"),
    "contact": (
        "hardening",
        "relaxation",
        "hysteresis",
        "clearance",
        "hunt_crossley",
    ),
    "torso": ("breathing", "reflex", "posture_drift"),
    "sensing": (
        "force_bias",
        "force_scale",
        "force_drift",
        "force_lag",
        "encoder_offset",
    ),
}
IDENTIFIERS = tuple(name for names in BY_BLOCK.values() for name in names)
