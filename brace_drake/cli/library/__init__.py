"""What there is: effects, motions, devices, those of plug-ins included."""
