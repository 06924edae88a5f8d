"""Any machine of one degree of freedom, linear or rotary, from its recording.

Its recorded motion is imposed on the twin, and the force that this takes is
compared: no loop has to be known, and no position drifts. Inside, everything is
counted in units of the machine's own size, so that laws and ranges of effects
serve a watch and a crane.
"""
