"""What an analysis found, told: findings with their place and figures, report.json, the page, the next experiment."""
