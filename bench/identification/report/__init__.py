"""The report of an identification: one self-contained HTML page with the paper's figures for this bench."""

from bench.identification.report.page import write_report

__all__ = ["write_report"]
