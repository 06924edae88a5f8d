"""Recordings that labs have, as campaigns: CSV, MATLAB, NI TDMS."""
