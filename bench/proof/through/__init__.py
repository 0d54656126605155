"""The examination through the bench itself: physics concealed in the plant, a campaign by the service's run process."""
