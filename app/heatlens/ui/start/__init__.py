"""How the program begins: what is offered, and what happens when something was opened."""
