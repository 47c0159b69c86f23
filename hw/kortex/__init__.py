"""The Kortex protocol: messages, frames, sessions, and a client of the arm's services."""
