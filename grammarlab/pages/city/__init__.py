"""The page of a city: its tiles, what is known of each parcel, and what is changed."""
