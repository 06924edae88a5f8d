"""What is recorded: each device's twin and the views on its recordings.

One folder for each device: `device.py` declares it (`Device`), `twin.py`
replays its runs, `block_tests.py` asks each of its blocks alone. `motions`
holds what a device may be asked to do. A new device is a folder like these, a
row of `device.DEVICES`, and a row of `effects.registry.PLACES` with the plug
points that it has.
"""
