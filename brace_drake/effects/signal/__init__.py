"""What commands suffer on their way to a drive, readings to a file."""
