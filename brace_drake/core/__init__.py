"""What every room may use: errors, output on disk, resources, parallel work."""
