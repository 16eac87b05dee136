document.title = "touchwarp";
