"""Numbers known to a tolerance beside a fit: led along with it where they bend,
and weighed beside what it leaves."""
