"""The page for the elements of a scan: their match, and corrections."""
