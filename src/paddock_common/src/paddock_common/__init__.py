"""What several of Paddock's packages need; it imports none of them."""
