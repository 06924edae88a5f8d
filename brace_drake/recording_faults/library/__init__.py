"""Cards of recording faults, a file each: its law and its test."""
