"""Campaigns from and to other files: CSV, MATLAB, NI TDMS, MCAP."""
