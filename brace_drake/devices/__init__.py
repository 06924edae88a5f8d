"""What is recorded: each device's twin and the views on its recordings.

One folder for each device: `device.py` declares it (`Device`), `twin.py`
replays its runs, `block_tests.py` asks each of its blocks alone. `motions`
holds what a device may be asked to do. `register_device` adds the device of
another package, see `registry.DeviceCard`.
"""

__all__ = ["DeviceCard", "register_device"]


def __getattr__(name: str):
    # The registry needs all devices, which import this package.
    if name in __all__:
        from brace_drake.devices import registry

        return getattr(registry, name)
    raise AttributeError(name)
