"""Campaigns: what they are, their plan, their run, their journal."""

from bench.campaigns.planning.definition import Block, Campaign, Order, Stage
from bench.campaigns.planning.file import load_campaign, parse_campaign, shipped_campaigns
from bench.campaigns.planning.plan import Plan, PlannedTask, make_plan

__all__ = [
    "Block",
    "Campaign",
    "Order",
    "Plan",
    "PlannedTask",
    "Stage",
    "load_campaign",
    "make_plan",
    "parse_campaign",
    "shipped_campaigns",
]
