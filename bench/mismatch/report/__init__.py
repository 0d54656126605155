"""What an analysis found, as a report: findings with place and figures, report.json, the page, the next experiment."""
