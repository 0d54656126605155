"""The twin: a model that watches a campaign, recording by recording, and says when it no longer holds."""
