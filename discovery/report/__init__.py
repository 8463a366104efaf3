"""The report: one self-contained HTML page."""

from discovery.report.page import write_report

__all__ = ["write_report"]
