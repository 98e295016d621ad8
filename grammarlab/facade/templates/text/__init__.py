"""The text format of templates: docs/facade-scans.md describes it."""
